"""The systems (29) and (33) of Yamada and Tatsumi (1981): as printed, and as they should read.

The paper breaks the matrix of (33) into two, side by side.
"""

from __future__ import annotations

#: (29) as printed.
PISTON_CRANK_PRINTED = r"""\begin{bmatrix}
-\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & 0 & 0 & 0 & 0 & 0 & 0 \\
-\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & -\cos \beta_1^0 & 0 & 0 & l_1^0 & 0 & 0 & 0 \\
\sin \beta_1^0 & -\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & 0 & 0 & 0 & -l_1^0 & 0 & 0 \\
\hline
0 & 0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & 0 & 0 & 0 & 0 \\
0 & 0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & -\cos \beta_2^0 & 0 & 0 & l_2^0 & 0 \\
0 & 0 & \sin \beta_2^0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & 0 & 0 & 0 & -l_2^0 \\
\hline
0 & 0 & 0 & 0 & -\cos \beta_3^0 & -\sin \beta_3^0 & \cos \beta_3^0 & \sin \beta_3^0 & 0 & 0 \\
0 & 0 & 0 & 0 & -\sin \beta_3^0 & \cos \beta_3^0 & \sin \beta_3^0 & -\cos \beta_3^0 & 0 & 0 \\
0 & 0 & 0 & 0 & \sin \beta_3^0 & -\cos \beta_3^0 & -\sin \beta_3^0 & \cos \beta_3^0 & 0 & 0 \\
\hline
\cos \beta_4^0 & \sin \beta_4^0 & 0 & 0 & 0 & 0 & -\cos \beta_4^0 & -\sin \beta_4^0 & 0 & 0 \\
\sin \beta_4^0 & -\cos \beta_4^0 & 0 & 0 & 0 & 0 & -\sin \beta_4^0 & \cos \beta_4^0 & 0 & 0 \\
-\sin \beta_4^0 & \cos \beta_4^0 & 0 & 0 & 0 & 0 & \sin \beta_4^0 & -\cos \beta_4^0 & 0 & 0
\end{bmatrix}
\begin{bmatrix}
u_1(0) \\ v_1(0) \\ u_2 \\ v_2 \\ u_3 \\ v_3 \\ \psi_{11}(\Delta\alpha) \\ \psi_{12} \\
\psi_{21} \\ \psi_{22}
\end{bmatrix}
=
\begin{bmatrix}
0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0
\end{bmatrix}"""

#: (29) as it should read.
PISTON_CRANK = r"""\begin{bmatrix}
-\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & 0 & 0 & 0 & 0 & 0 & 0 \\
-\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & -\cos \beta_1^0 & 0 & 0 & l_1^0 & 0 & 0 & 0 \\
\sin \beta_1^0 & -\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & 0 & 0 & 0 & -l_1^0 & 0 & 0 \\
\hline
0 & 0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & 0 & 0 & 0 & 0 \\
0 & 0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & -\cos \beta_2^0 & 0 & 0 & l_2^0 & 0 \\
0 & 0 & \sin \beta_2^0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & 0 & 0 & 0 & -l_2^0
\end{bmatrix}
\begin{bmatrix}
u_1(0) \\ v_1(0) \\ u_2 \\ v_2 \\ u_3 \\ v_3(0) \\ \psi_{11}(\Delta\alpha) \\ \psi_{12} \\
\psi_{21} \\ \psi_{22}
\end{bmatrix}
=
\begin{bmatrix}
0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0
\end{bmatrix}"""

#: (33) as printed.
LEVER_CRANK_PRINTED = r"""\begin{bmatrix}
-\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & 0 & 0 & 0 & 0 \\
-\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & -\cos \beta_1^0 & 0 & 0 & 0 & 0 \\
\sin \beta_1^0 & -\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & 0 & 0 & 0 & 0 \\
\hline
0 & 0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & 0 & 0 \\
0 & 0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & -\cos \beta_2^0 & 0 & 0 \\
0 & 0 & \sin \beta_2^0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & -\cos \beta_3^0 & -\sin \beta_3^0 & \cos \beta_3^0 & \sin \beta_3^0 \\
0 & 0 & 0 & 0 & -\sin \beta_3^0 & \cos \beta_3^0 & \sin \beta_3^0 & -\cos \beta_3^0 \\
0 & 0 & 0 & 0 & \sin \beta_3^0 & -\cos \beta_3^0 & -\sin \beta_3^0 & \cos \beta_3^0 \\
\hline
\cos \beta_4^0 & \sin \beta_4^0 & 0 & 0 & 0 & 0 & -\cos \beta_4^0 & -\sin \beta_4^0 \\
\sin \beta_4^0 & -\cos \beta_4^0 & 0 & 0 & 0 & 0 & -\sin \beta_4^0 & \cos \beta_4^0 \\
-\sin \beta_4^0 & \cos \beta_4^0 & 0 & 0 & 0 & 0 & \sin \beta_4^0 & -\cos \beta_4^0
\end{bmatrix}$$
$$\begin{bmatrix}
0 & 0 & 0 & 0 & 0 & 0 & 0 \\
l_1^0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & -l_1^0 & 0 & 0 & 0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & l_2^0 & 0 & 0 & 0 & 0 \\
0 & 0 & 0 & -l_2^0 & 0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & 0 & 0 & l_3^0 & 0 & 0 \\
0 & 0 & 0 & 0 & 0 & -l_3^0 & 0 \\
\hline
0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & 0 & 0 & 0 & l_4^0 & 0 \\
0 & 0 & 0 & 0 & 0 & 0 & -l_4^0
\end{bmatrix}
\begin{bmatrix}
u_1(0) \\ v_1(0) \\ u_2 \\ v_2 \\ u_3 \\ v_3 \\ u_4 \\ v_4 \\ \psi_{11}(\Delta\alpha) \\
\psi_{12} \\ \psi_{21} \\ \psi_{22} \\ \psi_{31} \\ \psi_{32} \\ \psi_{41} \\ \psi_{42}(0)
\end{bmatrix}
=
\begin{bmatrix}
0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0
\end{bmatrix}"""

#: (33) as it should read.
LEVER_CRANK = r"""\begin{bmatrix}
-\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & 0 & 0 & 0 & 0 \\
-\sin \beta_1^0 & \cos \beta_1^0 & \sin \beta_1^0 & -\cos \beta_1^0 & 0 & 0 & 0 & 0 \\
\sin \beta_1^0 & -\cos \beta_1^0 & -\sin \beta_1^0 & \cos \beta_1^0 & 0 & 0 & 0 & 0 \\
\hline
0 & 0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & 0 & 0 \\
0 & 0 & -\sin \beta_2^0 & \cos \beta_2^0 & \sin \beta_2^0 & -\cos \beta_2^0 & 0 & 0 \\
0 & 0 & \sin \beta_2^0 & -\cos \beta_2^0 & -\sin \beta_2^0 & \cos \beta_2^0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & -\cos \beta_3^0 & -\sin \beta_3^0 & \cos \beta_3^0 & \sin \beta_3^0 \\
0 & 0 & 0 & 0 & -\sin \beta_3^0 & \cos \beta_3^0 & \sin \beta_3^0 & -\cos \beta_3^0 \\
0 & 0 & 0 & 0 & \sin \beta_3^0 & -\cos \beta_3^0 & -\sin \beta_3^0 & \cos \beta_3^0 \\
\hline
\cos \beta_4^0 & \sin \beta_4^0 & 0 & 0 & 0 & 0 & -\cos \beta_4^0 & -\sin \beta_4^0 \\
\sin \beta_4^0 & -\cos \beta_4^0 & 0 & 0 & 0 & 0 & -\sin \beta_4^0 & \cos \beta_4^0 \\
-\sin \beta_4^0 & \cos \beta_4^0 & 0 & 0 & 0 & 0 & \sin \beta_4^0 & -\cos \beta_4^0
\end{bmatrix}
\begin{bmatrix}
0 & 0 & 0 & 0 & 0 & 0 & 0 & 0 \\
l_1^0 & 0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & -l_1^0 & 0 & 0 & 0 & 0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & l_2^0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & 0 & -l_2^0 & 0 & 0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & 0 & 0 & l_3^0 & 0 & 0 & 0 \\
0 & 0 & 0 & 0 & 0 & -l_3^0 & 0 & 0 \\
\hline
0 & 0 & 0 & 0 & 0 & 0 & 0 & 0 \\
0 & 0 & 0 & 0 & 0 & 0 & l_4^0 & 0 \\
0 & 0 & 0 & 0 & 0 & 0 & 0 & -l_4^0
\end{bmatrix}
\begin{bmatrix}
u_1(0) \\ v_1(0) \\ u_2 \\ v_2 \\ u_3 \\ v_3 \\ u_4 \\ v_4 \\ \psi_{11}(\Delta\alpha) \\
\psi_{12} \\ \psi_{21} \\ \psi_{22} \\ \psi_{31} \\ \psi_{32} \\ \psi_{41} \\ \psi_{42}(0)
\end{bmatrix}
=
\begin{bmatrix}
0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0
\end{bmatrix}"""
