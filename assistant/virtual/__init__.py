"""Virtual controllers that speak the real ones' protocols: ABB IRC5 and Mitsubishi CR.

with VirtualIrc5("home") as controller:
    print(controller.address, controller.password)
"""
