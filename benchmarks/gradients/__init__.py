"""What the gradient of a simulation costs, what it is made of, and how exact it is."""
