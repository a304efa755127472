// What the generated graph connects to: the devices of this board. None has a driver yet.
#pragma once
