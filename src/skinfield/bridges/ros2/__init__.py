"""ROS 2: a live skin over zenoh without ROS, or as a node within it."""
