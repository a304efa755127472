// Stands in for a graph and a board where a test has neither: nothing to run, nothing to come.
#include "stator/virtual.hpp"

namespace stator {

extern const Program program;
constinit const Program program{};

namespace board {
uint64_t next_event_us() {
    return kNever;
}
void advance(uint64_t /*now_us*/) {}
}  // namespace board

}  // namespace stator
