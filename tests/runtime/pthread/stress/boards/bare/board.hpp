// No device to connect.
#pragma once

#include "stator/pthread.hpp"
