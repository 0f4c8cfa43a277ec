r"""An interpreter of RAPID over its typed tree, independent of its translation.

A program that meets an instruction or function which is not simulated ends there as `unknown`, and
the message names it. Instructions of an option or an add-in of a controller can be added:

    def dispense(call: Given) -> None:
        amount = call.number(0)                      # Dispense 2.5 \Fast;
        call.machine.task.tell(Said(f"{amount} g"))

    run(tree, abilities={"Dispense": dispense})

`Given` evaluates the arguments on request: `value`, `number`, `truth`, `text`, `record` and `place`
by their position from 0, `optional` and `has` by the name of an option in lower case. A function
returns its value.
"""

from assistant.virtual.rapid.call_arguments import Ability, Given
from assistant.virtual.rapid.interpreter import Inputs, TaskProgram, run, run_tasks

__all__ = ["Ability", "Given", "Inputs", "TaskProgram", "run", "run_tasks"]
