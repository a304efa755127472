// What the generated graph connects to: this board has no devices.
#pragma once

#include "stator/virtual.hpp"
