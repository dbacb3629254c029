//! From a scan, points or a mesh, to a mesh that can be deformed (paper Sec. IV-B 1-2).
