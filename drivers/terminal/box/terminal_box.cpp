// Passes requests of terminals on to the graph, and the answers back.
#include "terminal_box.hpp"

#include <bit>

namespace stator::drivers::terminal::box {

void TerminalBox::step(TerminalPorts& ports) {
    while (ports.value.next()) {
        const ParameterValue& value = *ports.value;
        const bool is_ours =
            value.requester == ParameterValue::Requester::kLink && value.tag == tag_ && is_waiting_;
        if (!is_ours) continue;
        is_waiting_ = false;
        const bool is_float = value.type == ParameterValue::Type::kFloat;
        device_.box.answer({.value = is_float ? std::bit_cast<uint32_t>(value.float_value)
                                              : std::bit_cast<uint32_t>(value.int_value),
                            .result = static_cast<uint8_t>(value.result)});
    }
    if (is_waiting_ && ports.now >= until_us_) {
        is_waiting_ = false;
        device_.box.answer({.value = 0, .result = ParameterBox::kNoAnswer});
    }
    ParameterBox::Ask ask;
    if (is_waiting_ || !device_.box.take(ask)) return;
    is_waiting_ = true;
    until_us_ = ports.now + kAnswerTime_us;
    ++tag_;
    const auto type = static_cast<ParameterRequest::Type>(ask.type);
    const bool is_float = type == ParameterRequest::Type::kFloat;
    ports.request.publish([&] {
        return ParameterRequest{.requester = ParameterRequest::Requester::kLink,
                                .tag = tag_,
                                .action = static_cast<ParameterRequest::Action>(ask.action),
                                .type = type,
                                .index = ask.index,
                                .float_value = is_float ? std::bit_cast<float>(ask.value) : 0.0F,
                                .int_value = is_float ? 0 : std::bit_cast<int32_t>(ask.value)};
    });
}

}  // namespace stator::drivers::terminal::box
