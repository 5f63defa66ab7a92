"""What the simulator leaves out because a scene does not need it: what that saves, and that it changes nothing."""
