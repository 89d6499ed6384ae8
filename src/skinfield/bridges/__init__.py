"""Bridges: estimates where robots listen, over zenoh, ROS 2 and YARP."""
