"""The documents, in parts: the entries of each in TOML, and beside them its words and proofs.

``lecture_7_1`` and ``lecture_8_2``, whose words stand in ``lecture_8_2_words``; the paper of Yamada
and Tatsumi (1981) by its sections, ``link_element``, ``link_method`` and ``link_examples``, with
its mechanisms in ``link_mechanisms`` and its iteration in ``link_iteration``; ``mass_points``.
"""
