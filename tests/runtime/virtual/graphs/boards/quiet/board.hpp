// No device to connect.
#pragma once

#include "stator/virtual.hpp"
