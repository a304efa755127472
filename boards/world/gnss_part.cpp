// A satellite receiver as a part of the world.
#include "world/gnss_part.hpp"

namespace stator::world {

GnssPart::GnssPart(const World& world)
    : receiver_(parameters_, world.conditions().earth, world.conditions().seed) {}

std::optional<GnssFix> GnssPart::receive(const World& world) {
    const std::uint64_t now_us = world.time_us();
    std::optional<GnssFix> arrived;
    if (sending_ && now_us >= sending_->arrival_us) {
        if (sending_->arrives) arrived = sending_->fix;
        sending_.reset();
    }
    if (timer_.take(now_us)) {
        const Faults& faults = world.conditions().faults;
        sending_ = receiver_.measure(
            world.plant(), {.lost = faults.now(FaultKind::kGnssLoss, now_us).has_value(),
                            .glitch = faults.now(FaultKind::kGnssGlitch, now_us).value_or(0.0)});
    }
    return arrived;
}

}  // namespace stator::world
