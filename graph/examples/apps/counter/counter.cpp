#include "counter.hpp"

namespace stator::apps::counter {

void Counter::step(CounterPorts& ports) {
    if (static_cast<float>(ports.now) < ports.params->rest * 1e6F) return;
    ++counted_;
    const uint32_t first = static_cast<uint32_t>(ports.params->first);
    ports.count.publish(
        [&] { return Count{.timestamp_sample = ports.now, .value = first + counted_}; });
}

}  // namespace stator::apps::counter
