// The topic that the explorer explores.
#pragma once

#include "stator/one_core_topic.hpp"
