// A test finds the lines by their comments.
#include "breaks.hpp"

#include <cstdio>

namespace stator::apps::breaks {

[[gnu::noinline]] int Breaks::descend(int n) {
    return n < zero_ ? n : descend(n + 1) + zero_;
}

void Breaks::step(BreaksPorts& ports) {
    ++count_;
    ports.count.publish([&] { return CrashCount{.value = count_}; });
    if (ports.now < 1'000'000) return;
    const int how = ports.params->how;
    if (how == 1)
        zero_ = ports.status->arming_state == VehicleStatus::ArmingState::kArmed;  // absent
    if (how == 2) *reinterpret_cast<volatile int*>(ports.now) = 1;                 // segv
    if (how == 3) zero_ = 5 / zero_;                                               // fpe
    if (how == 4) __builtin_abort();                                               // abort
    while (how == 5 && zero_ == 0) {                                               // endless
    }
    if (how == 6) zero_ = descend(0);  // recursion
    if (how == 7 && ports.now < 1'002'000) std::printf("count %u\n", count_);
    if (how == 8) values_[static_cast<unsigned>(how + zero_)] = 1;  // bounds
}

}  // namespace stator::apps::breaks
