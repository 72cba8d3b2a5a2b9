"""What a user describes: scenes, and the records that every stage shares."""
