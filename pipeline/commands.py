"""The table of subcommands; a stage is imported when one of its own is asked for."""

from typing import Final

COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "run": ("pipeline.run:Run", "a sentence to human motion, robot trajectory, verdict, pictures, servos"),
    "actions": ("generator.actions_cli:Actions", "what sentences may ask for"),
    "generate": ("generator.cli:Generate", "a sentence to human motion"),
    "retarget": ("retarget.cli:Retarget", "a human motion to a robot's trajectory"),
    "convert": ("ros_free_stack.formats.cli:Convert", "a motion file to another format"),
    "validate": ("pipeline.validate:Validate", "judge a trajectory in MuJoCo, and repair it on request"),
    "render": ("sim.cli:Render", "draw a trajectory as a video"),
    "play": ("sim.view.play:Play", "show a motion in a window or a browser"),
    "stream": ("pipeline.stream:Stream", "play a validated trajectory on servos, real or virtual"),
    "data build": ("generator.corpus.cli:DataBuild", "make the training corpus"),
    "data show": ("generator.corpus.cli:DataShow", "draw one clip of the corpus"),
    "data coverage": ("generator.corpus.cli:DataCoverage", "what of real captions the corpus can say"),
    "ground": ("generator.grounding.cli:Ground", "where in a motion each part of a sentence happens"),
    "caption": ("generator.grounding.cli:Caption", "the texts that a motion's segments are most like"),
    "train": ("generator.cli:Train", "train a model of the generator"),
    "evaluate": ("generator.evaluation.cli:Evaluate", "measure the generator against real motion"),
    "robots list": ("ros_free_stack.cli:RobotsList", "the robots that are described"),
    "robots show": ("ros_free_stack.cli:RobotsShow", "one robot's joints and limits"),
    "robots add": ("retarget.describe.cli:RobotsAdd", "describe a robot from its MuJoCo model"),
    "servos scan": ("hw.commands.look:ServosScan", "which servos answer on a port"),
    "servos info": ("hw.commands.look:ServosInfo", "what each servo is and how it is set"),
    "servos read": ("hw.commands.look:ServosRead", "position, current, temperature, voltage of each servo"),
    "servos configure": ("hw.commands.setup:ServosConfigure", "set servos up for the robot, changes shown first"),
    "servos calibrate": ("hw.commands.setup:ServosCalibrate", "directions and zeros of a real rig"),
    "servos reboot": ("hw.commands.safety:ServosReboot", "clear hardware errors"),
    "servos release": ("hw.commands.safety:ServosRelease", "torque off"),
    "servos power": ("hw.commands.safety:ServosPower", "give the servos their power, or take it"),
    "servos emulate": ("hw.virtual.cli:ServosEmulate", "an emulated bus for other programs"),
    "servos simulate": ("pipeline.simulate:Simulate", "an emulated bus whose servos move the robot in MuJoCo"),
    "doctor": ("ros_free_stack.cli:Doctor", "what this machine has and lacks"),
    "completion": ("pipeline.completion:Completion", "completion of commands and options in a shell"),
}
"""Subcommand to the module and class that does it, and one line of help."""
