// What a node may see of its graph: in virtual time nothing else runs meanwhile.
#include "stator/observe.hpp"

#include "stator/one_core_copy.hpp"

namespace stator {

TaskCounters figures_of(const ObservedTask& task) {
    return *task.counters;
}

uint32_t observed_ticks_hz() {
    return 0;
}

bool copy_newest(const Topic& topic, uint8_t* to, size_t bytes, uint32_t& number) {
    return copy_newest_below(topic, to, bytes, number);
}

}  // namespace stator
