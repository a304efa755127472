// Runs the graph in real time and prints the trace, if the machine was fast enough for it to say
// anything: what belongs to one step of a scenario has to be over before the next one begins.
//
// Exit status: 0 it was; 1 the graph did not start or did not come to rest; 3 the machine was late.
#include <atomic>
#include <cstdio>
#include <string>

#include "board.hpp"
#include "stator/mutex.hpp"

namespace stator {

namespace board {

drivers::button::test::ButtonTest::Device finger0{.press = [] { button0_pressed.raise(); }};
drivers::button::test::ButtonTest::Device button0;
Line button0_pressed;

}  // namespace board

namespace {

constexpr uint64_t kHalfStep_us = trace::kStep_us / 2;
constexpr int kLate = 3;

Mutex mutex;
std::string text;  // under the mutex
std::atomic<bool> is_late{false};

}  // namespace

void trace::write(const char* line, uint64_t now_us) {
    if (now_us > kEnd_us) return;  // before the levels have been told that it is over
    if (clock_us() >= now_us + kHalfStep_us) is_late.store(true);
    const Lock lock(&mutex);
    text += line;
}

}  // namespace stator

int main() {
    using namespace stator;
    text.reserve(1U << 16);
    if (!start()) return 1;
    // In the middle of each step there is a moment at which all levels sleep, so that no activation
    // of this step is still to come. One whose release itself is late says so when it writes.
    for (uint64_t middle_us = kHalfStep_us; middle_us <= trace::kEnd_us;
         middle_us += trace::kStep_us) {
        wait_until(middle_us);
        const bool is_idle = wait_until_idle(kHalfStep_us / 2);
        if (!is_idle || clock_us() >= middle_us + kHalfStep_us) is_late.store(true);
    }
    if (!finish()) return 1;
    std::fputs(text.c_str(), stdout);
    return is_late.load() ? kLate : 0;
}
