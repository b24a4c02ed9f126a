"""The explorer: a local page on which the whole analysis is live (``slipfold explore``)."""
