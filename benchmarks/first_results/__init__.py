"""Twenty-four sentences over eight objects: what was asked, simulated, perceived and true, and what a viewer sees."""
