// Runs the graph in virtual time and prints the trace.
#include <cstdio>

#include "board.hpp"

namespace stator {

namespace board {

drivers::button::test::ButtonTest::Device finger0{.press = [] { button0_pressed.raise(); }};
drivers::button::test::ButtonTest::Device button0;
Line button0_pressed;

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
    stator::start();
    stator::run_until(stator::trace::kEnd_us);
    return 0;
}
