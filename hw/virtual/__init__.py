"""An emulated Dynamixel bus: Protocol 2.0 over a pseudo terminal, a control table and a motor for each servo."""
