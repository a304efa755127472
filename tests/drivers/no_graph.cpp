// The executor's other half for tests that call nodes without a graph: no tasks, no events.
#include "stator/virtual.hpp"

namespace stator {

constinit const Program program{};

namespace board {
uint64_t next_event_us() {
    return kNever;
}
void advance(uint64_t /*now_us*/) {}
}  // namespace board

}  // namespace stator
