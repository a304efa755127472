// What the generated graph connects to.
#pragma once

#include "probe_counted.hpp"
#include "storage_sim.hpp"

namespace stator::board {

extern ProbeCounted::Device probe0;
extern StorageSim::Device log_storage;

}  // namespace stator::board
