// Asks for changes of parameters at fixed times: good ones, and one of each kind that is refused.
#pragma once

#include <array>
#include <limits>
#include <string_view>

#include "tuner_ports.hpp"

namespace stator::apps::tuner {

class Tuner {
  public:
    void step(TunerPorts& ports) {
        if (next_ == kScript.size() || ports.now < kScript[next_].time_us) return;
        const Line& line = kScript[next_++];
        ports.request.publish([&] {
            ParameterRequest request{.tag = static_cast<uint8_t>(next_),
                                     .action = ParameterRequest::Action::kSet,
                                     .type = line.type,
                                     .float_value = line.float_value * scale(line, ports),
                                     .int_value = line.int_value};
            for (size_t i = 0; i < line.name.size(); ++i) {
                request.name[i] = static_cast<uint8_t>(line.name[i]);
            }
            return request;
        });
    }

  private:
    using Type = ParameterRequest::Type;
    struct Line {
        uint64_t time_us;
        std::string_view name;
        Type type;
        float float_value;
        int32_t int_value;
    };
    static constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    static constexpr std::array<Line, 9> kScript{{
        {1'000'000, "position_control.no_such", Type::kFloat, 1.0F, 0},
        {1'100'000, "rate_control.pitch_p", Type::kFloat, 5.1F, 0},
        {1'200'000, "rate_control.pitch_p", Type::kFloat, kNaN, 0},
        {1'300'000, "rate_control.pitch_p", Type::kInt32, 0.0F, 1},
        {1'400'000, "tuner.scale", Type::kFloat, 0.5F, 0},
        {4'000'000, "rate_control.pitch_p", Type::kFloat, 0.28F, 0},
        {4'100'000, "allocation.airmode", Type::kBool, 0.0F, 1},
        {4'300'000, "allocation.airmode", Type::kBool, 0.0F, 0},
        {4'400'000, "rate_control.pitch_p", Type::kFloat, 0.7F, 0},
    }};

    // A node sees its own change, too.
    static float scale(const Line& line, const TunerPorts& ports) {
        return line.time_us > 1'400'000 ? ports.params->scale : 1.0F;
    }

    size_t next_ = 0;
};

}  // namespace stator::apps::tuner
