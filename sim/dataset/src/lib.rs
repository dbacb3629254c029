//! A dataset of dented objects: what is made, by whom, and how it is kept (paper Sec. IV-B 8, VI-A).
