// The topic of this executor, where levels run at once.
#pragma once

#include "stator/ring_topic.hpp"
