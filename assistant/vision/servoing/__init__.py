"""Visual servoing: control an arm by what cameras see, picture by picture.

A `ControlLaw` computes from what is seen how the tool must move, a `Carrier` of the controllers
room sends the steps to the arm, and `servo` (`servo_loop.py`) runs the loop and keeps the limits.
Neither law nor loop depends on the protocol to the controller.
"""
