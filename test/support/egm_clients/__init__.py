"""EGM clients as others write them; each a program of its own, since they claim names of protobuf.

They take a port, a number of packets, and how far axis 5 shall go [deg]; they print how many
packets they took and answered, and how far they ended from where they wanted to go [deg].
"""
