// Topologies by enumeration, and the slot formula of the compiler (codegen/stator/plan/topics.py)
// once more; a test compares the two.
#include "topology.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

namespace stator::explorer {

namespace {

constexpr std::array kRoles = {'r', 'q', 'w', 'b', 'B'};

bool has_one_to_three_publishers(const Topology& topology) {
    const auto count = std::ranges::count_if(
        topology.users, [](const TopicUser& user) { return user.role.publishes(); });
    return count >= 1 && count <= 3;
}

}  // namespace

std::string Topology::name() const {
    std::ostringstream text;
    for (const TopicUser& user : users) {
        text << user.level << user.role.letter;
        if (user.burst > 1) text << user.burst;
        text << ' ';
    }
    text << "depth " << depth;
    return text.str();
}

unsigned Topology::top() const {
    unsigned top = 0;
    for (const TopicUser& user : users) {
        if (user.role.publishes()) top = std::max(top, user.level);
    }
    return top;
}

unsigned Topology::ceiling() const {
    const unsigned highest = top();
    const bool several = std::ranges::any_of(users, [=](const TopicUser& user) {
        return user.role.publishes() && user.level != highest;
    });
    return several ? highest : 0;
}

bool Topology::takes_turns() const {
    return depth == 1 && std::ranges::all_of(users, [this](const TopicUser& user) {
               if (user.role.publishes()) return user.level == top() && !user.role.reads();
               return user.level >= top();
           });
}

bool Topology::is_read_above(unsigned level) const {
    return std::ranges::any_of(
        users, [=](const TopicUser& user) { return user.role.reads() && user.level > level; });
}

unsigned Topology::slots() const {
    const unsigned highest = top();
    const unsigned kept = depth - 1 + (is_read_above(highest) ? 1 : 0);
    unsigned at_top = 0;
    std::map<unsigned, unsigned> held;
    for (const auto& [level, role, burst] : users) {
        const unsigned reads = role.reads() ? 1 : 0;
        if (level < highest) held[level] = std::max(held[level], reads + role.publishes());
        if (level != highest || !role.publishes()) continue;
        const unsigned oldest = (role.reads_queue() ? depth : 1) + burst - 1;
        at_top = std::max(at_top, kept + (oldest > kept ? reads : 0) + 1);
    }
    for (const auto& [level, holds] : held) at_top += holds;
    return at_top;
}

Topology parse_topology(const std::string& text, unsigned depth) {
    Topology topology{{}, depth};
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const auto burst = word.size() > 2 ? static_cast<unsigned>(std::stoul(word.substr(2))) : 1U;
        topology.users.push_back({static_cast<unsigned>(word[0] - '0'), {word[1]}, burst});
    }
    return topology;
}

std::vector<Topology> all_topologies(unsigned levels, unsigned depth) {
    std::vector<Topology> all = {Topology{{}, depth}};
    for (unsigned level = 1; level <= levels; ++level) {
        std::vector<Topology> longer;
        for (const Topology& topology : all) {
            for (const char role : kRoles) {
                longer.push_back(topology);
                longer.back().users.push_back({level, {role}});
            }
        }
        all = longer;
    }
    std::erase_if(all, [](const Topology& t) { return !has_one_to_three_publishers(t); });
    return all;
}

std::vector<Topology> shared_level_topologies(unsigned levels, unsigned depth) {
    std::vector<Topology> all;
    for (unsigned shared = 1; shared <= levels; ++shared) {
        for (const char first : kRoles) {
            for (const char second : kRoles) {
                if (first >= second) continue;
                if (levels == 1) {
                    all.push_back({{{1, {first}}, {1, {second}}}, depth});
                    continue;
                }
                for (const char other : kRoles) {
                    Topology topology{{{shared, {first}}, {shared, {second}}}, depth};
                    const bool below = shared == 2;
                    topology.users.insert(below ? topology.users.begin() : topology.users.end(),
                                          {3 - shared, {other}});
                    all.push_back(topology);
                }
            }
        }
    }
    std::erase_if(all, [](const Topology& t) { return !has_one_to_three_publishers(t); });
    return all;
}

std::vector<Topology> with_burst(std::vector<Topology> topologies, unsigned burst) {
    const auto reads_its_own = [](const TopicUser& user) {
        return user.role.reads() && user.role.publishes();
    };
    std::erase_if(topologies,
                  [&](const Topology& t) { return std::ranges::none_of(t.users, reads_its_own); });
    for (Topology& topology : topologies) {
        for (TopicUser& user : topology.users) user.burst = reads_its_own(user) ? burst : 1;
    }
    return topologies;
}

}  // namespace stator::explorer
