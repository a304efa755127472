// The executor of activation_test.cpp: at every access of a shared word a more urgent job may come
// in.
#pragma once

#include <cstdint>

namespace stator {

namespace testing {
void pass_point();
}

struct Pend {
    uint32_t word;
    uint32_t mask;
};
inline void set_pending(const Pend&) {}
inline void preempt() {}
inline void preemption_point() {
    testing::pass_point();
}
inline void require(bool, const char*) {}

struct Section {
    explicit Section(unsigned) {}
};

}  // namespace stator
