"""Estimates where robots listen: zenoh, ROS 2, YARP."""
