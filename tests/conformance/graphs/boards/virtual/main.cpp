// Runs the graph in virtual time and prints the trace.
#include <cstdio>

#include "devices.hpp"

namespace stator {

namespace board {

uint64_t next_event_us() {
    return kNever;
}
void advance(uint64_t) {}

}  // namespace board

void trace::write(const char* line, uint64_t) {
    std::fputs(line, stdout);
}

}  // namespace stator

int main() {
    stator::board::finger0.press = [] { stator::board::button0_pressed.raise(); };
    stator::start();
    stator::run_until(stator::trace::kEnd_us);
    return 0;
}
