"""Wheels over a scanned running surface: the path of their centres, an irregularity of decks."""
