#include "endless.hpp"

namespace stator::apps::endless {

void Endless::step(EndlessPorts& ports) {
    const uint32_t counted = counted_ + 1;
    counted_ = counted;
    ports.count.publish([&] { return Count{.timestamp_sample = ports.now, .value = counted}; });
    while (counted_ >= 3) {
    }
}

}  // namespace stator::apps::endless
