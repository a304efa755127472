// Parameters on their way to stations, and their wishes on the way back.
#pragma once

#include <array>

#include "link.hpp"
#include "mavlink_ports.hpp"

namespace stator::apps::mavlink {

// One question at a time is on its way to the node that has all parameters. Questions and wishes of
// stations wait in a short queue, and go before lists; one that finds no room is not answered, and
// its station repeats it. A value that changed is told on all lines.
class ParameterTransfer {
  public:
    // False: not a message about parameters.
    bool handle(Link& link, unsigned number, const mav::Frame& frame, const MavlinkPorts& ports);
    // Once in each activation, behind all messages: `lines` are all lines.
    template <class Lines>
    void step(Lines& lines, MavlinkPorts& ports) {
        while (ports.parameter.next()) {
            const ParameterValue& value = *ports.parameter;
            if (!is_answer(value) || is_asked_again(value, ports)) continue;
            const bool is_for_all = value.result == ParameterValue::Result::kWritten;
            for (unsigned i = 0; i < lines.size(); ++i) {
                if (is_for_all || i == asked_.line) tell(lines[i].link, value);
            }
            end(value);
        }
        if (asked_.is_one && ports.now - asked_us_ > kPatience_us) asked_.is_one = false;
        for (unsigned i = 0; i < kLines && !asked_.is_one; ++i) {
            ask_next(lines[list_line_].link, ports);
        }
    }

  private:
    static constexpr unsigned kQueue = 8;
    static constexpr unsigned kLines = 2;
    static constexpr uint16_t kNoList = UINT16_MAX;
    static constexpr uint64_t kPatience_us = 500'000;
    static constexpr std::size_t kIdLength = 16;

    struct Question {
        bool is_one = false;
        bool is_of_list = false;
        unsigned line = 0;
        mav::Address from{};
        std::array<char, kIdLength> id{};  // empty: by index
        uint16_t index = 0;
        bool sets = false;
        ParameterRequest::Type type = ParameterRequest::Type::kFloat;
        float value = 0.0F;  // its bits count
    };

    void queue(const Question& question);
    void ask_next(const Link& link, MavlinkPorts& ports);
    void ask(const Question& question, MavlinkPorts& ports);
    bool is_answer(const ParameterValue& value) const;
    bool is_asked_again(const ParameterValue& value, MavlinkPorts& ports);
    void tell(Link& link, const ParameterValue& value) const;
    void end(const ParameterValue& value);
    void refuse(Link& link, const mav::Address& to, const std::array<char, kIdLength>& id,
                int16_t index, uint32_t why) const;

    std::array<Question, kQueue> queue_{};
    unsigned begin_ = 0;
    unsigned waiting_ = 0;
    Question asked_;
    uint8_t tag_ = 0;
    uint64_t asked_us_ = 0;
    std::array<uint16_t, kLines> list_next_{kNoList,
                                            kNoList};  // of each line: the list's next index
    unsigned list_line_ = 0;                           // whose turn it is
};

}  // namespace stator::apps::mavlink
