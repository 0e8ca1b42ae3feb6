# For a tap: brew install --HEAD TAP/piste, with HOMEBREW_PISTE_SOURCE the address of the repository. A release names
# its homepage, and its archive by `url` and `sha256`.
class Piste < Formula
  desc "Trajectory and IMU errors from raw logs of a MEMS-IMU and GNSS"
  license "MIT"
  head ENV.fetch("HOMEBREW_PISTE_SOURCE", "file:///usr/local/src/piste"), using: :git, branch: "main"

  depends_on "boost" => :build
  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "ceres-solver"
  depends_on "eigen"
  depends_on "fmt"
  depends_on "geographiclib"
  depends_on "yaml-cpp"

  resource "dygraphs-script" do
    url "https://cdn.jsdelivr.net/npm/dygraphs@2.2.1/dist/dygraph.min.js"
    sha256 "79022073ab2d4276b204339c19131a686c7176c075c68317a46d6073225a6510"
  end

  resource "dygraphs-style" do
    url "https://cdn.jsdelivr.net/npm/dygraphs@2.2.1/dist/dygraph.min.css"
    sha256 "26c4ef2356454f40e108e4d9649bf92139671cb49ef214ec1879fd8ffad848c9"
  end

  resource "leaflet-script" do
    url "https://cdn.jsdelivr.net/npm/leaflet@1.9.4/dist/leaflet.js"
    sha256 "db49d009c841f5ca34a888c96511ae936fd9f5533e90d8b2c4d57596f4e5641a"
  end

  resource "leaflet-style" do
    url "https://cdn.jsdelivr.net/npm/leaflet@1.9.4/dist/leaflet.css"
    sha256 "a7837102824184820dfa198d1ebcd109ff6d0ff9a2672a074b9a1b4d147d04c6"
  end

  def install
    plots = buildpath/"plots"
    resources.each { |file| plots.install file }
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", *std_cmake_args,
           "-DBUILD_SHARED_LIBS=ON", "-DPISTE_TESTS=OFF", "-DPISTE_UNITY=ON", "-DDygraphs_DIR=#{plots}", "-DLeaflet_DIR=#{plots}"
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    system bin/"piste-simulate", share/"piste/scenarios/ski_run.yaml", "--output", "logs", "--quiet"
    system bin/"piste-inspect", "logs/mt9a_1.csv", "logs/gnss.csv", "--output", "inspection", "--quiet"
    system bin/"piste-replay", "inspection/replay.yaml", "--output", "run", "--quiet"
    assert_path_exists testpath/"run/smoothed.csv"
  end
end
