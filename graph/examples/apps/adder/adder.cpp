#include "adder.hpp"

namespace stator::apps::adder {

void Adder::step(AdderPorts& ports) {
    // Reads every kind of input alike: one sample of a trigger, the newest, or all of a queue.
    // Absent samples add nothing.
    while (ports.count.next()) sum_ += ports.count->value;
    const uint32_t extra = ports.extra ? ports.extra->value : 0;
    ports.sum.publish([&] { return Count{.timestamp_sample = ports.now, .value = sum_ + extra}; });
}

}  // namespace stator::apps::adder
