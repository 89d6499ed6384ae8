"""A live skin where ROS 2 listens: over zenoh without ROS, or as a node within it."""
