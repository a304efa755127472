// One request about a parameter and its answer, between the side that serves a link and the driver
// that passes requests on to the graph.
#pragma once

#include <cstdint>

#include "stator/topic.hpp"

namespace stator {

// Neither side ever waits. The link's side may be less urgent than all tasks, or another thread; it
// is one context, and so is the driver's. Who holds the words below says `state_`.
class ParameterBox {
  public:
    struct Ask {
        uint16_t index;  // of the parameter, in the order of ids
        uint16_t tag;    // tells a new request from a repeated one
        uint8_t action;  // as in ParameterRequest, like the type
        uint8_t type;
        uint32_t value;

        bool operator==(const Ask&) const = default;
    };
    struct Answer {
        uint32_t value;
        uint8_t result;  // as in ParameterValue
    };
    static constexpr uint8_t kNoAnswer = 0xFF;  // the result, if the graph did not answer in time

    enum class Progress : uint8_t {
        kUnserved,  // of the link: there is no driver for it
        kPending,   // ask the same again
        kBusy,      // with the request of another client; ask again
        kConcluded
    };

    // --- the link's side ---

    Progress ask(const Ask& request, Answer& answer) {
        const uint32_t state = state_.load();
        const bool is_same = request == ask_;
        if (state == kAnswered && is_same) {
            answer = answer_;
            return Progress::kConcluded;
        }
        if (state != kFree && state != kAnswered) {
            return is_same ? Progress::kPending : Progress::kBusy;
        }
        ask_ = request;
        state_.store(kAsked);
        return Progress::kPending;
    }

    // --- the driver's side ---

    bool take(Ask& request) {
        if (state_.load() != kAsked) return false;
        request = ask_;
        state_.store(kTaken);
        return true;
    }
    // Of the request that was taken last; another answer counts no more.
    void answer(const Answer& answer) {
        if (state_.load() != kTaken) return;
        answer_ = answer;
        state_.store(kAnswered);
    }

  private:
    static constexpr uint32_t kFree = 0;
    static constexpr uint32_t kAsked = 1;
    static constexpr uint32_t kTaken = 2;
    static constexpr uint32_t kAnswered = 3;

    Shared<uint32_t> state_{kFree};
    Ask ask_{};
    Answer answer_{};
};

// Of the graph that runs; a board whose graph has the driver sets it before the start.
inline ParameterBox* parameter_box = nullptr;

}  // namespace stator
