// What the generated graph connects to.
#pragma once

#include "drivers/probe/counted/probe_counted.hpp"
#include "drivers/storage/sim/storage_sim.hpp"

namespace stator::board {

extern drivers::probe::counted::ProbeCounted::Device probe0;
extern drivers::storage::sim::StorageSim::Device log_storage;

}  // namespace stator::board
