// The topic of this executor, where jobs nest on one core.
#pragma once

#include "stator/one_core_topic.hpp"
