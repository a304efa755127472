// Items of the mission device, a window of them at a time: what is not there yet is asked for.
#pragma once

#include <optional>

#include "item.hpp"
#include "messages/mission_request.hpp"
#include "navigator_ports.hpp"

namespace stator::apps::navigator {

// In each activation: `begin`, any number of `item`, `finish`.
class ItemReader {
  public:
    using List = MissionItems::List;

    void begin(const NavigatorPorts& ports) {
        window_ = ports.items ? &*ports.items : nullptr;
        is_wanted_ = false;
    }

    // Nothing: it is not there. The first one that is missing is asked for.
    std::optional<RawItem> item(List list, uint32_t id, unsigned index) {
        if (window_ != nullptr && window_->list == list && window_->id == id &&
            index >= window_->first && index - window_->first < window_->count) {
            return raw_item(*window_, index - window_->first);
        }
        if (!is_wanted_)
            wanted_ = {.first = static_cast<uint16_t>(index), .list = to_request(list)};
        is_wanted_ = true;
        return {};
    }

    // Publishes the request. One that is not answered is repeated now and then.
    void finish(NavigatorPorts& ports, float dt) {
        waited_s_ += dt;
        if (!is_wanted_) return;
        const bool is_asked = wanted_.first == asked_.first && wanted_.list == asked_.list;
        if (is_asked && waited_s_ < kPatience_s) return;
        asked_ = wanted_;
        waited_s_ = 0.0F;
        ports.request.publish([&] { return wanted_; });
    }

  private:
    static constexpr float kPatience_s = 0.1F;

    static MissionRequest::List to_request(List list) {
        return static_cast<MissionRequest::List>(list);
    }

    const MissionItems* window_ = nullptr;
    MissionRequest wanted_{};
    MissionRequest asked_{};
    bool is_wanted_ = false;
    float waited_s_ = kPatience_s;
};

}  // namespace stator::apps::navigator
