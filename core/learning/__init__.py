"""What only training and research need: corpora, data sets, training, systems to compare, metrics, evaluation."""
