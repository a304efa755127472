// What drivers of the mission device have in common: loads, answers requests, takes uploads. The
// memory is the port of mission_store.hpp.
#pragma once

#include "mission_ports.hpp"
#include "mission_store.hpp"

namespace stator::drivers::mission {

template <class Port>
class MissionDriver {
  public:
    using Store = MissionStore<Port>;

    explicit MissionDriver(Port port) : store_(port) {}

    // `is_lost`: the memory is gone, as far as anyone can see.
    void step(MissionPorts& ports, bool is_lost) {
        const bool was_loaded = store_.is_loaded();
        store_.load_some();
        bool is_news = (store_.is_loaded() && !was_loaded) || is_lost != was_lost_;
        was_lost_ = is_lost;
        while (ports.upload.next()) is_news = take(*ports.upload) || is_news;
        if (ports.download.next()) read_out(ports, *ports.download);
        if (ports.request.is_new()) answer(ports, *ports.request);
        if (is_news && store_.is_loaded()) tell(ports);
    }

  private:
    static constexpr unsigned kMission = 0;
    static constexpr unsigned kFence = 1;
    static constexpr unsigned kRally = 2;
    static constexpr unsigned kDownloads = 2;  // items: the burst of the output

    // Says whether there is something to tell.
    bool take(const MissionUpload& part) {
        using Action = MissionUpload::Action;
        const auto list = static_cast<unsigned>(part.list);
        bool is_done = false;
        switch (part.action) {
            case Action::kBegin:
                is_done = store_.begin(list, part.count);
                break;
            case Action::kItems:
                is_done = add(list, part);
                break;
            case Action::kCommit:
                is_done = store_.commit(list, part.id);
                break;
        }
        if (!is_done) ++refused_;
        return !is_done || part.action == Action::kCommit;
    }

    bool add(unsigned list, const MissionUpload& part) {
        bool is_done = part.count <= part.command.size();
        for (unsigned i = 0; is_done && i < part.count; ++i) {
            is_done = store_.add(list, part.first + i,
                                 {.command = part.command[i],
                                  .frame = part.frame[i],
                                  .autocontinue = part.autocontinue[i],
                                  .param1 = part.param1[i],
                                  .param2 = part.param2[i],
                                  .param3 = part.param3[i],
                                  .param4 = part.param4[i],
                                  .x = part.x[i],
                                  .y = part.y[i],
                                  .z = part.z[i]});
        }
        return is_done;
    }

    // As many items as there are from there on, up to what a message holds.
    void answer(MissionPorts& ports, const MissionRequest& request) {
        const auto list = static_cast<unsigned>(request.list);
        if (list >= Store::kLists || was_lost_) return;
        ports.items.publish([&] {
            MissionItems items{};
            items.id = store_.list(list).id;
            items.first = request.first;
            items.list = static_cast<MissionItems::List>(request.list);
            unsigned count = 0;
            for (; count < items.command.size(); ++count) {
                StoredItem item{};
                const unsigned index = request.first + count;
                if (index >= store_.list(list).count || !store_.read(list, index, item)) break;
                items.command[count] = item.command;
                items.frame[count] = item.frame;
                items.autocontinue[count] = item.autocontinue;
                items.param1[count] = item.param1;
                items.param2[count] = item.param2;
                items.param3[count] = item.param3;
                items.param4[count] = item.param4;
                items.x[count] = item.x;
                items.y[count] = item.y;
                items.z[count] = item.z;
            }
            items.count = static_cast<uint8_t>(count);
            return items;
        });
    }

    // One download in each activation.
    void read_out(MissionPorts& ports, const MissionRequest& wanted) {
        const auto list = static_cast<unsigned>(wanted.list);
        if (list >= Store::kLists || was_lost_) return;
        for (unsigned i = 0; i < kDownloads; ++i) {
            StoredItem item{};
            const unsigned index = wanted.first + i;
            if (index >= store_.list(list).count || !store_.read(list, index, item)) return;
            ports.downloaded.publish([&] {
                return MissionItem{.id = store_.list(list).id,
                                   .index = static_cast<uint16_t>(index),
                                   .list = static_cast<MissionItem::List>(wanted.list),
                                   .frame = item.frame,
                                   .command = item.command,
                                   .autocontinue = item.autocontinue,
                                   .param1 = item.param1,
                                   .param2 = item.param2,
                                   .param3 = item.param3,
                                   .param4 = item.param4,
                                   .x = item.x,
                                   .y = item.y,
                                   .z = item.z};
            });
        }
    }

    void tell(MissionPorts& ports) {
        const auto id = [this](unsigned list) { return was_lost_ ? 0 : store_.list(list).id; };
        const auto count = [this](unsigned list) {
            return static_cast<uint16_t>(was_lost_ ? 0 : store_.list(list).count);
        };
        ports.mission.publish([&] {
            return Mission{.mission_id = id(kMission),
                           .geofence_id = id(kFence),
                           .safe_points_id = id(kRally),
                           .refused = refused_,
                           .count = count(kMission),
                           .geofence_count = count(kFence),
                           .safe_points_count = count(kRally)};
        });
    }

    Store store_;
    uint32_t refused_ = 0;
    bool was_lost_ = false;
};

}  // namespace stator::drivers::mission
