// What the generated graph connects to.
#pragma once

#include "probe_counted.hpp"

namespace stator::board {

extern ProbeCounted::Device probe0;

}  // namespace stator::board
