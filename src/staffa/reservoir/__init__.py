"""Reservoir simulators: flow of water and heat between wells, each in a separate program."""
