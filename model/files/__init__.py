"""Files of generated folders and of the cache: manifests, named arrays, JSON, digests."""
