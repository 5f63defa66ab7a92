"""What is measured about results: motion against the truth, similarity of pictures and words, image errors."""
