from rrrobot.machines.snakeboards import snakeboard as snakeboard
