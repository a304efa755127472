// Spoils the samples of one device, as the faults of its name say.
//
// It knows nothing of the device: a sample says which quantities it has by each_quantity(visit),
// which calls visit("name", span) for each of them, and when it was measured by timestamp_sample.
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string_view>

#include "world/noise.hpp"
#include "world/world.hpp"

namespace stator::world {

// Adds to, cuts and turns round the values of one quantity.
template <class Number>
void spoil_quantity(const Fault& fault, std::string_view quantity, std::span<Number> values,
                    std::uint64_t now_us, math::Random& random) {
    const std::string_view wanted = fault.quantity.data();
    if (!wanted.empty() && wanted != quantity) return;
    const double spike = random.uniform_double() < 0.01 ? fault.value : 0.0;
    const double since_s = static_cast<double>(now_us - fault.from_us) * 1e-6;
    if (fault.kind == FaultKind::kSwappedAxis && values.size() > 1) std::swap(values[0], values[1]);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (fault.axis >= 0 && static_cast<std::size_t>(fault.axis) != i) continue;
        auto value = static_cast<double>(values[i]);
        if (fault.kind == FaultKind::kOffset) value += fault.value;
        if (fault.kind == FaultKind::kDrift) value += fault.value * since_s;
        if (fault.kind == FaultKind::kNoise) value += fault.value * random.gaussian_double();
        if (fault.kind == FaultKind::kSpike) value += spike;
        if (fault.kind == FaultKind::kSaturation)
            value = math::clamp(value, -fault.value, fault.value);
        if (fault.kind == FaultKind::kWrongSign) value = -value;
        values[i] = static_cast<Number>(value);
    }
}

template <class Sample>
class Spoiler {
  public:
    Spoiler(const World& world, std::string_view part)
        : part_(part), random_(world.conditions().seed, stream_of(part)) {
        for (const Fault& fault : world.conditions().faults) is_sound_ &= !fault.is_of(part);
    }

    // What the device gives now, of what it measured now.
    std::optional<Sample> spoil(std::optional<Sample> measured, const World& world) {
        if (is_sound_) return measured;
        const Faults& faults = world.conditions().faults;
        const std::uint64_t now_us = world.time_us();
        const auto has = [&](FaultKind kind) { return faults.now(part_, kind, now_us); };
        if (measured) {
            if (has(FaultKind::kStuck)) repeat(*measured);
            last_ = measured;
            for (const Fault& fault : faults) {
                if (fault.is_of(part_) && fault.acts(now_us)) apply(fault, *measured, now_us);
            }
            const double late = has(FaultKind::kDelay).value_or(0.0);
            if (!has(FaultKind::kDropOut))
                under_way_.push_back({now_us + microseconds(late), *measured});
        }
        if (under_way_.empty()) return {};
        // What overtakes those before it takes their place.
        if (under_way_.back().due_us <= now_us)
            under_way_.erase(under_way_.begin(), under_way_.end() - 1);
        if (under_way_.front().due_us > now_us) return {};
        const Sample sample = under_way_.front().sample;
        under_way_.pop_front();
        return sample;
    }

  private:
    static std::uint64_t microseconds(double seconds) {
        return math::saturate<std::uint64_t>(math::round(seconds * 1e6));
    }

    void repeat(Sample& measured) const {
        if (!last_) return;
        Sample again = *last_;
        if constexpr (requires { measured.timestamp_sample; })
            again.timestamp_sample = measured.timestamp_sample;
        measured = again;
    }

    void apply(const Fault& fault, Sample& sample, std::uint64_t now_us) {
        if constexpr (requires { sample.timestamp_sample; }) {
            if (fault.kind == FaultKind::kTimeJump)
                sample.timestamp_sample += microseconds(fault.value);
        }
        const auto visit = [&](std::string_view quantity, auto values) {
            spoil_quantity(fault, quantity, values, now_us, random_);
        };
        if constexpr (requires { sample.each_quantity(visit); }) sample.each_quantity(visit);
    }

    struct UnderWay {
        std::uint64_t due_us;
        Sample sample;
    };
    std::string_view part_;
    math::Random random_;
    bool is_sound_ = true;
    std::optional<Sample> last_;  // as it was before the fault, while it is stuck
    std::deque<UnderWay> under_way_;
};

}  // namespace stator::world
