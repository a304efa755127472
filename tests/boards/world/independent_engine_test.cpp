// One manoeuvre of the plant against an independent engine, MuJoCo: the same thrusts and drags at
// the same places of the same body, moved by other code in other frames with another step.
//
// MuJoCo's world is north-west-up, its body forward-left-up; what it is given is in these.
#include <gtest/gtest.h>

#include "iris.hpp"
#include "world/plant.hpp"

#ifdef STATOR_MUJOCO
#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace stator::world {
namespace {

constexpr double kDuration = 1.6;     // s
constexpr double kHeight = 100.0;     // m, far from the ground
constexpr double kEngineStep = 1e-4;  // s; forces that depend on velocity are held for as long

// Climbs, flips over its right side while pitching and yawing, and spins on: thrusts of the rotors
// from each time on.
struct Phase {
    double begin;
    Controls control;
};
constexpr std::array<Phase, 4> kManoeuvre{{{0.0, {0.7F, 0.7F, 0.7F, 0.7F}},
                                           {0.3, {0.3F, 0.9F, 0.95F, 0.2F}},
                                           {0.6, {0.8F, 0.7F, 0.1F, 0.4F}},
                                           {1.1, {0.2F, 0.1F, 0.5F, 0.6F}}}};

// The rotor's speed, by the exponentials that solve its lag.
double rotor_speed(const Airframe& quad, unsigned rotor, double time) {
    double speed = 0.0;
    for (std::size_t i = 0; i < kManoeuvre.size(); ++i) {
        const double begin = kManoeuvre[i].begin;
        if (time <= begin) break;
        const double end = i + 1 < kManoeuvre.size() ? kManoeuvre[i + 1].begin : kDuration;
        const double commanded =
            quad.most_rotor_speed * std::sqrt(static_cast<double>(kManoeuvre[i].control[rotor]));
        const double tau = commanded > speed ? quad.rise_time_constant : quad.fall_time_constant;
        speed = commanded + (speed - commanded) * std::exp(-(std::min(time, end) - begin) / tau);
    }
    return speed;
}

std::string model(const Airframe& quad) {
    const auto number = [](double value) { return std::to_string(value) + " "; };
    std::string sites;
    std::string motors;
    for (unsigned i = 0; i < 4; ++i) {
        const Rotor& rotor = quad.rotors[i];
        const std::string name = "\"r" + std::to_string(i) + "\"";
        sites += "<site name=" + name + " pos=\"" + number(rotor.place_B.x()) +
                 number(-rotor.place_B.y()) + "0\"/>";
        motors += "<motor site=" + name + " gear=\"0 0 1 0 0 " +
                  number(-rotor.turns_ccw * quad.torque_per_thrust) + "\"/>";
    }
    return "<mujoco><compiler inertiafromgeom=\"false\"/><option integrator=\"RK4\" timestep=\"" +
           number(kEngineStep) + "\" gravity=\"0 0 -9.80665\"/><worldbody><body name=\"quad\">" +
           "<freejoint/><inertial pos=\"0 0 0\" mass=\"" + number(quad.mass) + "\" diaginertia=\"" +
           number(quad.inertia.xx) + number(quad.inertia.yy) + number(quad.inertia.zz) + "\"/>" +
           sites + "</body></worldbody><actuator>" + motors + "</actuator></mujoco>";
}

// Where it is after the manoeuvre, from where it began.
struct End {
    Vector3 position_N;
    Quaternion q_NB;
    double turned = 0.0;  // rad, in all
};

class Engine {
  public:
    explicit Engine(const Airframe& quad) : quad_(quad) {
        const std::string path = testing::TempDir() + "stator_quad.xml";
        const std::string text = model(quad);
        std::FILE* const file = std::fopen(path.c_str(), "wb");
        std::fwrite(text.data(), 1, text.size(), file);
        std::fclose(file);
        std::array<char, 500> error{};
        model_ = mj_loadXML(path.c_str(), nullptr, error.data(), error.size());
        EXPECT_NE(model_, nullptr) << error.data();
        std::remove(path.c_str());
        data_ = mj_makeData(model_);
    }
    ~Engine() {
        mj_deleteData(data_);
        mj_deleteModel(model_);
    }
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

    End fly() {
        const long steps = std::lround(kDuration / kEngineStep);
        for (long step = 0; step < steps; ++step) {
            mj_forward(model_, data_);
            mju_zero(data_->qfrc_applied, model_->nv);
            for (unsigned i = 0; i < 4; ++i) {
                push(i, rotor_speed(quad_, i, (static_cast<double>(step) + 0.5) * kEngineStep));
            }
            mj_step(model_, data_);
        }
        const mjtNum* const q = data_->qpos;
        return {Vector3(q[0], -q[1], -q[2]), Quaternion(q[3], q[4], -q[5], -q[6])};
    }

  private:
    // Thrust and drag of one rotor by its own speed through the air.
    void push(unsigned i, double speed) {
        std::array<mjtNum, 6> velocity{};  // turning, then moving; in the site's frame
        mj_objectVelocity(model_, data_, mjOBJ_SITE, static_cast<int>(i), velocity.data(), 1);
        const double climb = velocity[5];
        data_->ctrl[i] = quad_.thrust_per_speed2 * speed * (speed - climb / quad_.inflow_pitch);
        const double drag = quad_.rotor_drag * speed;
        const std::array<mjtNum, 3> force_B{-drag * velocity[3], -drag * velocity[4], 0.0};
        const double roll = quad_.rotors[i].turns_ccw * quad_.rolling_moment * speed;
        const std::array<mjtNum, 3> torque_B{-roll * velocity[3], -roll * velocity[4], 0.0};
        std::array<mjtNum, 3> force{};
        std::array<mjtNum, 3> torque{};
        const mjtNum* const rotation = data_->site_xmat + 9 * i;
        mju_rotVecMat(force.data(), force_B.data(), rotation);
        mju_rotVecMat(torque.data(), torque_B.data(), rotation);
        mj_applyFT(model_, data_, force.data(), torque.data(), data_->site_xpos + 3 * i, 1,
                   data_->qfrc_applied);
    }

    Airframe quad_;
    mjModel* model_ = nullptr;
    mjData* data_ = nullptr;
};

End fly_plant(const Airframe& quad) {
    VehicleState start;
    start.position_N.z() = -kHeight;
    Plant plant(quad, start);
    double turned = 0.0;
    for (int step = 0; step < std::lround(kDuration * 1e3); ++step) {
        for (const Phase& phase : kManoeuvre) {
            if (step == std::lround(phase.begin * 1e3)) plant.command(phase.control);
        }
        plant.step(1e-3);
        turned += 1e-3 * plant.state().rate_B.norm();
    }
    return {plant.state().position_N + Vector3(0.0, 0.0, kHeight), plant.state().q_NB, turned};
}

TEST(IndependentEngine, flies_the_same_flip) {
    Airframe quad = iris().airframe;
    quad.drag_area_B.setZero();  // MuJoCo has no such drag
    const End ours = fly_plant(quad);
    const End theirs = Engine(quad).fly();
    // It has moved by metres, and turned round; else this tells little.
    EXPECT_GT(ours.position_N.norm(), 3.0);
    EXPECT_GT(ours.turned, 2.0 * M_PI);
    // MuJoCo holds drag and inflow for 0.1 ms. That makes 0.4 mm and 0.4 mrad, half as much at half
    // the step.
    EXPECT_NEAR((ours.position_N - theirs.position_N).norm(), 0.0, 6e-4);
    EXPECT_NEAR(ours.q_NB.angularDistance(theirs.q_NB), 0.0, 6e-4);
}

}  // namespace
}  // namespace stator::world

#else

TEST(IndependentEngine, flies_the_same_flip) {
    GTEST_SKIP() << "the plant was not compared with another engine: MuJoCo is not installed; "
                    "apt-get install libmujoco-dev (0.6 MB), and configure again";
}

#endif
