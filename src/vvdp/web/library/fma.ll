declare <2 x double> @llvm.wasm.relaxed.madd.v2f64(<2 x double>, <2 x double>, <2 x double>)

define internal double @vvdp_fma(double %a, double %b, double %c) alwaysinline nounwind {
  %a0 = insertelement <2 x double> poison, double %a, i64 0
  %b0 = insertelement <2 x double> poison, double %b, i64 0
  %c0 = insertelement <2 x double> poison, double %c, i64 0
  %x = shufflevector <2 x double> %a0, <2 x double> poison, <2 x i32> zeroinitializer
  %y = shufflevector <2 x double> %b0, <2 x double> poison, <2 x i32> zeroinitializer
  %z = shufflevector <2 x double> %c0, <2 x double> poison, <2 x i32> zeroinitializer
  %both = call <2 x double> @llvm.wasm.relaxed.madd.v2f64(<2 x double> %x, <2 x double> %y, <2 x double> %z)
  %one = extractelement <2 x double> %both, i64 0
  ret double %one
}
