double fma(double,double,double),pow(double,double),exp(double),log(double),sin(double),cos(double),expm1(double),log1p(double),erf(double),erfc(double),asin(double),tanh(double),fmod(double,double);
