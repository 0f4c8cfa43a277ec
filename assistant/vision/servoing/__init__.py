"""Visual servoing: an arm that is led by what cameras see, picture by picture.

A `Law` (`image_based.py`, `pose_based.py`) tells from what is seen how the tool is to move, a
`Carrier` of `controllers.leading` takes the steps to the arm, and `servo` (`loop.py`) goes round
between them and keeps the limits. Neither law nor loop knows by which way the arm is led.
"""
