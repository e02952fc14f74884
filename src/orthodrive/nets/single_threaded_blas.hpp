#pragma once
// OpenBLAS keeps threads of its own beside those of libtorch and of our windows; they only wait for each other.

namespace orthodrive {

/// While it lives, matrix products of OpenBLAS run on the thread that asks for them. Nothing with another BLAS.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;

 private:
  int before_ = 0;  ///< 0: there is no OpenBLAS
};

}  // namespace orthodrive
