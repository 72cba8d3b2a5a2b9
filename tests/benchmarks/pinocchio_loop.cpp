// Pinocchio's articulated-body algorithm for a chain, through a loop without Python.
#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/aba.hpp>

#include <cstddef>
#include <string>

namespace {

struct Chain {
    pinocchio::Model model;
    pinocchio::Data *data;
};

}  // namespace

// lives until the program ends
extern "C" void *chain_new(
    std::size_t count, double mass, const double *centre, const double *moments, const double *gravity)
{
    auto *chain = new Chain;
    pinocchio::Model &model = chain->model;
    model.gravity.linear() = Eigen::Map<const Eigen::Vector3d>(gravity);
    const Eigen::Vector3d middle = Eigen::Map<const Eigen::Vector3d>(centre);
    const Eigen::Matrix3d tensor = Eigen::Map<const Eigen::Vector3d>(moments).asDiagonal();
    pinocchio::JointIndex parent = 0;
    for (std::size_t k = 0; k < count; ++k) {
        pinocchio::SE3 place = pinocchio::SE3::Identity();
        if (k) place.translation() = Eigen::Vector3d(1, 0, 0);
        const std::string name = "joint_" + std::to_string(k);
        parent = k % 2 ? model.addJoint(parent, pinocchio::JointModelRZ(), place, name)
                       : model.addJoint(parent, pinocchio::JointModelRY(), place, name);
        model.appendBodyToJoint(
            parent, pinocchio::Inertia(mass, middle, tensor), pinocchio::SE3::Identity());
    }
    chain->data = new pinocchio::Data(model);
    return chain;
}

extern "C" void chain_loop(
    void *handle, std::size_t rounds, std::size_t states, const double *q, const double *v, double *a)
{
    using Vector = Eigen::VectorXd;
    auto *chain = static_cast<Chain *>(handle);
    const auto n = chain->model.nv;
    const Vector torque = Vector::Zero(n);
    Vector angles(n), rates(n);
    for (std::size_t r = 0; r < rounds; ++r) {
        for (std::size_t s = 0; s < states; ++s) {
            angles = Eigen::Map<const Vector>(q + s * n, n);
            rates = Eigen::Map<const Vector>(v + s * n, n);
            pinocchio::aba(chain->model, *chain->data, angles, rates, torque);
            Eigen::Map<Vector>(a + s * n, n) = chain->data->ddq;
        }
    }
}
